"""Build and installation of auv_core."""

from setuptools import find_packages, setup

package_name = "auv_core"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(include=[package_name, f"{package_name}.*"]),
    package_data={package_name: ["models/presets/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="The Shoal authors",
    maintainer_email="shoal@example.org",
    description="Shared definitions of Shoal: geometry, vehicle models, data between components",
    license="Apache-2.0",
)

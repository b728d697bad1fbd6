"""Build and installation of auv_thesis."""

from setuptools import find_packages, setup

package_name = "auv_thesis"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(include=[package_name, f"{package_name}.*"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="The Shoal authors",
    maintainer_email="shoal@example.org",
    description="The thesis reproduced with Shoal: its figures, tables and claims, made from runs",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "reproduce = auv_thesis.cli:main",
        ],
    },
)

"""Build and installation of auv_sim."""

from setuptools import find_packages, setup

package_name = "auv_sim"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(include=[package_name, f"{package_name}.*"]),
    package_data={package_name: ["acoustics/presets/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="The Shoal authors",
    maintainer_email="shoal@example.org",
    description="The simulator of Shoal: the true vehicle and the acoustic medium",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "vehicle_node = auv_sim.nodes.vehicle_node:main",
            "acoustic_relay_node = auv_sim.nodes.acoustic_relay_node:main",
        ],
    },
)

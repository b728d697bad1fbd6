"""Build and installation of auv_bringup."""

from glob import glob

from setuptools import find_packages, setup

package_name = "auv_bringup"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(include=[package_name, f"{package_name}.*"]),
    package_data={package_name: ["scenarios/*.yaml", "studies/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
        (f"share/{package_name}/launch", sorted(glob("launch/*.launch.py"))),
        (f"share/{package_name}/config", sorted(glob("config/*"))),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="The Shoal authors",
    maintainer_email="shoal@example.org",
    description="Composition of Shoal: scenarios, launcher, recorder, replay, metrics, report",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "node_container = auv_bringup.nodes.node_container:main",
            "recorder_node = auv_bringup.nodes.recorder_node:main",
            "run = auv_bringup.cli:main",
            "replay = auv_bringup.replay:main",
            "reproduce = auv_bringup.reproduction.cli:main",
            "sweep = auv_bringup.sweeps.cli:main",
            "topic = auv_bringup.topic:main",
        ],
    },
)

"""Build and installation of auv_bringup."""

from glob import glob

from setuptools import find_packages, setup

package_name = "auv_bringup"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(include=[package_name, f"{package_name}.*"]),
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
    description="Commands of Shoal that need ROS 2: launcher, replay, topic command, launch file",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "node_container = auv_bringup.nodes.node_container:main",
            "run = auv_bringup.tools.run:main",
            "replay = auv_bringup.tools.replay:main",
            "topic = auv_bringup.tools.topic:main",
        ],
    },
)

"""Build and installation of auv_ros."""

from setuptools import find_packages, setup

package_name = "auv_ros"

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
    description="Turns the pure objects of Shoal into ROS 2 nodes: life cycle, parameters, messages",
    license="Apache-2.0",
)

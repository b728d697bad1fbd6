"""Build and installation of auv_flocking."""

from setuptools import find_packages, setup

package_name = "auv_flocking"

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
    description="Control of the group in Shoal: consensus, neighbour filters, flocking laws, the agent",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "agent_node = auv_flocking.nodes.agent_node:main",
        ],
    },
)

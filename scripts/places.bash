# Paths of the checkout, and the ROS 2 in use. Sourced by `setup` and `activate.bash`; changes nothing.
#
#   root        the checkout
#   ros_kind    wheels: ROS 2 from PyPI, inside the venv;  jazzy: the ROS 2 Jazzy that is sourced in this shell
#   ros_prefix  folder of that sourced ROS's rclpy (empty for wheels)
#   ros_python  the Python that it was made for, like 3.12 (empty for wheels)
#   venv        the venv that goes with it

root=$(cd -P -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd) || exit 1

# An rclpy in a prefix that is no venv is an installed ROS 2; one in a venv belongs to this or another
# checkout.
find_sourced_ros() {
  local prefix module
  ros_kind=wheels ros_prefix='' ros_python=''
  local IFS=:
  for prefix in ${AMENT_PREFIX_PATH:-}; do
    [ -e "$prefix/pyvenv.cfg" ] && continue
    for module in "$prefix"/lib/python3.*/site-packages/rclpy; do
      [ -d "$module" ] || continue
      ros_kind=jazzy ros_prefix=$prefix
      ros_python=${module#"$prefix"/lib/python}
      ros_python=${ros_python%%/*}
      return
    done
  done
}

find_sourced_ros
if [ "$ros_kind" = jazzy ]; then venv=$root/.venv-jazzy; else venv=$root/.venv; fi

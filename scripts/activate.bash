# Sourced by the commands in this folder: set up what is missing, then bring up the venv, ROS 2 and the workspace.

source "$(dirname -- "${BASH_SOURCE[0]}")/places.bash"

# uv, colcon, ROS 2 and matplotlib all need a writable home; provide one if it is missing.
can_write_in() { [ -d "$1" ] && [ -w "$1" ]; }

if ! can_write_in "${HOME:-}"; then
  HOME=$root/log/home
  if ! { mkdir -p "$HOME" && can_write_in "$HOME"; } 2>/dev/null; then # another user's checkout
    HOME=${TMPDIR:-/tmp}/shoal-$UID
    mkdir -m 700 "$HOME" 2>/dev/null
    [ ! -L "$HOME" ] && [ -O "$HOME" ] && [ "$(stat -c %a "$HOME")" = 700 ] || HOME=$(mktemp -d) || exit 1
  fi
  export HOME
fi

"$root/scripts/setup" || exit 1

# Variables of other workspaces and venvs in this shell do not belong to ours.
if [ "$ros_kind" = wheels ]; then unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH PYTHONPATH; fi
# These wheels have Fast DDS only.
if [ "$ros_kind" = wheels ]; then unset RMW_IMPLEMENTATION; fi
unset PYTHONHOME
export VIRTUAL_ENV=$venv PATH=$venv/bin:$PATH
set +u
source "$root/install/setup.bash"
# The command `shoal`, which colcon puts where `ros2 run` looks for it.
export PATH=$root/install/shoal/lib/shoal:$PATH
# Ten processes import the same modules at every start: let Python keep compiled modules.
unset PYTHONDONTWRITEBYTECODE
#  All matrices here are small: threads of the linear algebra would only wait for each other (on a busy
# machine the inverse of a 6 x 6 matrix takes twenty times as long), and the last bits may differ from those
# of the nodes, which have one thread.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

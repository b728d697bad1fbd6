# Extends `source install/setup.bash` beside an installed ROS 2 Jazzy. Sourced by `setup`, after
# `places.bash`.  There `ros2` runs under the Python of the system, which does not use our venv. So the
# install folder gets an additional entry of the kind that colcon makes for each package, with the venv's
# site-packages for PYTHONPATH. All of setup.* and local_setup.* read it, and a manual `colcon build` does not
# change it. ROS 2 from PyPI is in the venv and needs no entry.

venv_entry=$root/install/shoal_venv

venv_entry_text() { printf 'append-non-duplicate;PYTHONPATH;%s\n' "$venv/lib/python$ros_python/site-packages"; }

has_venv_on_path() {
  [ "$ros_kind" = jazzy ] || return 0
  [ -e "$venv_entry/share/colcon-core/packages/shoal_venv" ] &&
    [ "$(cat "$venv_entry/share/shoal_venv/package.dsv" 2>/dev/null)" = "$(venv_entry_text)" ]
}

put_venv_on_path() {
  mkdir -p "$venv_entry/share/colcon-core/packages" "$venv_entry/share/shoal_venv"
  venv_entry_text >"$venv_entry/share/shoal_venv/package.dsv"
  : >"$venv_entry/share/colcon-core/packages/shoal_venv" # depends on no other package
}

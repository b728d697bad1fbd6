# Common part of the commands written in bash: help and errors as in the Python commands. Sourced; changes
# nothing.

# Print the command's leading comment and end, if the first argument asks for help.
say_help_if_asked() { # ARGUMENT...
  case ${1-} in
    -h | --help) sed -n '2,/^[^#]/{/^[^#]/d; s/^# \{0,1\}//; p;}' "$0"; exit 0 ;;
  esac
}

refuse() { # LINE: print what is not allowed, and end
  printf 'error: %s (./scripts/%s --help says more)\n' "$1" "${0##*/}" >&2
  exit 2
}

# What the commands written in bash share: help and complaints as the Python commands give them. Sourced; changes nothing.

# Print the command's leading comment where the first argument asks for help, and end.
say_help_if_asked() { # ARGUMENT...
  case ${1-} in
    -h | --help) sed -n '2,/^[^#]/{/^[^#]/d; s/^# \{0,1\}//; p;}' "$0"; exit 0 ;;
  esac
}

refuse() { # LINE: say what is not allowed, and end
  printf 'error: %s (./scripts/%s --help says more)\n' "$1" "${0##*/}" >&2
  exit 2
}

"""
Parts of the documentation that are generated from code at each build of the site.

A page includes one with a comment, ``<!-- from code: topics -->``, which `hook.py` replaces. A module makes
one, as Markdown, from the source of the facts: fields of dataclasses, message files, the topics of the
recorder, the help of commands.
"""

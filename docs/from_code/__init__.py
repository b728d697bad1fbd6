"""
Parts of the documentation that are made from code, each time that the site is built.

A page asks for one with a comment, ``<!-- from code: topics -->``; `hook.py` puts it there.  A module makes
one, as Markdown, from the place where the fact is stated: fields of dataclasses, message files, the topics of
the recorder, the help of commands.
"""

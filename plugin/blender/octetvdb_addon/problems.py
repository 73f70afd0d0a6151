# SPDX-License-Identifier: Apache-2.0
"""Errors as reports: what goes wrong in an operator is told by Blender, without a traceback."""
import functools


class Problem(Exception):
    """Something that the artist has to put right; the text says what."""


def describe(error):
    """One line on an error. The library's own errors and Problems are written for people."""
    from . import library
    known = (Problem, OSError)
    if library.octetvdb is not None:
        known += (library.octetvdb.Error,)
    text = " ".join(str(error).split())
    text = text[:1].upper() + text[1:]
    if isinstance(error, MemoryError) and not isinstance(error, known):
        return "Not enough memory"
    return text if isinstance(error, known) else f"Internal error: {type(error).__name__}: {text}"


def reported(method):
    """Makes an operator's method(self, context) report its errors and cancel."""
    @functools.wraps(method)
    def run(self, context):
        try:
            return method(self, context)
        except Exception as error:  # noqa: B902 - whatever it is, artists get a report
            self.report({"ERROR"}, describe(error))
            return {"CANCELLED"}
    return run

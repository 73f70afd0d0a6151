# SPDX-License-Identifier: Apache-2.0
"""The Python module octetvdb: the one in the add-on's own folder, else an installed one."""
from .problems import Problem

try:
    from . import octetvdb
except ImportError as bundled:
    # Another Python than it was compiled for, or the add-on used from the source tree.
    try:
        import octetvdb
    except ImportError:
        octetvdb = None
        missing = f"the library octetvdb cannot be loaded: {bundled}"


def need():
    """The module; a Problem where there is none."""
    if octetvdb is None:
        raise Problem(missing)
    return octetvdb

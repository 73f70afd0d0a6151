# SPDX-License-Identifier: Apache-2.0
"""The Python module octetvdb: the one in the add-on's own folder, else an installed one."""
import os

from .problems import Problem


def _let_run(name):
    """Blender unpacks add-ons without the permission to run the programs in them."""
    program = os.path.join(os.path.dirname(__file__), "octetvdb", name)
    if os.path.exists(program) and not os.access(program, os.X_OK):
        try:
            os.chmod(program, 0o755)
        except OSError:
            pass  # the library tells of it where it is needed


_let_run("octetvdb-gmsh")
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

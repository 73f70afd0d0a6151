# SPDX-License-Identifier: Apache-2.0
"""The cage that operators work on."""
from . import cage_mesh
from .problems import Problem


def cage(context):
    """The active object if it is a cage, else the scene's cage."""
    active = context.active_object
    if cage_mesh.is_cage(active):
        return active
    chosen = context.scene.octetvdb.cage
    if chosen is None or not cage_mesh.is_cage(chosen):
        raise Problem("Make a cage first")
    if not chosen.users_scene:
        raise Problem(f'the cage "{chosen.name}" was deleted: make another')
    return chosen

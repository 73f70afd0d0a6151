# SPDX-License-Identifier: Apache-2.0
"""OctetVDB for Blender: draw a cage and guide curves, get an incompressible flow as an OpenVDB volume.

Thin over the Python module octetvdb, which is bundled with it. Modules: `library` finds that module;
`problems` turns errors into reports; `action` is what operators share; `properties` is what is stored
in the .blend; `cage_mesh`, `guides`, `primitives`, `flow_data` and `volume` translate between
Blender's data and the library's; `cage`, `flow`, `preview` and `bake` are the operators, `panel`
shows them.
"""

bl_info = {
    "name": "OctetVDB",
    "author": "OctetVDB contributors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D Viewport > Sidebar > OctetVDB",
    "description": "Art-directed, exactly incompressible velocity fields for volumes",
    "doc_url": "",
    "category": "Physics",
}

from . import bake, cage, flow, panel, preview, properties

_ROOMS = (properties, cage, flow, preview, bake, panel)


def register():
    for room in _ROOMS:
        room.register()


def unregister():
    for room in reversed(_ROOMS):
        room.unregister()

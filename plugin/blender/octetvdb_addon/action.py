# SPDX-License-Identifier: Apache-2.0
"""What the add-on's operators share."""
from .problems import reported


class Action:
    """An operator, together with bpy.types.Operator, that does its work in run(context): it can be
    undone, and its errors are reports. run returns None where it finished."""
    bl_options = {"REGISTER", "UNDO"}

    @reported
    def execute(self, context):
        return self.run(context) or {"FINISHED"}

# SPDX-License-Identifier: Apache-2.0
"""Pictures, from a compiled module of their own: loaded when first asked for, since it needs libraries
that nothing else does."""


def preview(source, path, **options):
    """Draws a slice or a 3d view of a ControlAsset or of a .vdb, as a PNG.

    The options are those of octetvdb._pictures.preview: form, view ("slice", "3d"), style, quantity,
    levels, frame, axis, position, width, height, labels, progress. ImportError when octetvdb was built
    without pictures.
    """
    from . import _pictures
    _pictures.preview(source, path, **options)

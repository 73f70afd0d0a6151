# SPDX-License-Identifier: Apache-2.0
"""Types of the compiled module that draws."""
from ._octetvdb import ControlAsset, _Progress

def preview(
    source: ControlAsset | str,
    path: str,
    *,
    form: str = ...,
    view: str = ...,
    style: str = ...,
    quantity: str = ...,
    levels: int | None = ...,
    frame: int = ...,
    axis: str = ...,
    position: float | None = ...,
    width: int = ...,
    height: int = ...,
    labels: bool = ...,
    progress: _Progress = ...,
) -> None: ...

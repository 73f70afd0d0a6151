# SPDX-License-Identifier: Apache-2.0
"""The bake: on a thread of its own, so that the window stays alive, with progress and Esc."""
import functools
import threading

import bpy

from . import cage_mesh, current, flow, flow_data, library, volume
from .action import Action
from .problems import Problem, reported

# Seconds between looks at the thread.
_TICK = 0.1


class Job:
    """A bake that runs without Blender: all it needs was collected before."""

    def __init__(self, work):
        self._work, self._stop = work, False
        self.stage, self.fraction = "", 0.0
        self.report = self.error = None
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self):
        self._thread.start()

    def cancel(self):
        self._stop = True

    def running(self):
        return self._thread.is_alive()

    def run_here(self):
        self._run()

    def progress(self, stage, done, total, unit):
        """The library's progress callback, on the thread that works."""
        self.stage, self.fraction = stage, done / total if total else 0.0
        return not self._stop

    def _run(self):
        try:
            self.report = self._work(self.progress)
        except Exception as error:  # noqa: B902 - told by the operator
            self.error = error


def prepare(context, cage):
    """Collects all that a bake needs; returns the job and the frames of a sequence or None."""
    octetvdb = library.need()
    settings = cage.octetvdb
    control = cage_mesh.read(cage)
    path = volume.absolute(settings.path)
    options = {"target": "blender", "half": settings.half}
    if settings.size_mode == "VOXEL":
        options["voxel_size"] = settings.voxel_size
    else:
        options["resolution"] = settings.resolution
    if not settings.use_frames:
        flux, boundary = flow_data.load(cage, control)
        asset = flow_data.make_asset(control, flow_data.about(context, cage), flux)

        def work(progress):
            return octetvdb.bake(asset, path, boundary=boundary, progress=progress, **options)
        return Job(work), None

    frames = list(range(settings.frame_first, settings.frame_last + 1))
    if not frames:
        raise Problem("The last frame is before the first")
    found = _gather_frames(context, cage, frames)
    fit_options, walls = flow.fit_options(cage, control), flow.wall_options(cage, control)
    # Units and settings are read here: Blender's data belongs to the main thread.
    make_asset = functools.partial(flow_data.make_asset, control, flow_data.about(context, cage))

    def fit_and_bake(progress):
        make_fit = functools.lru_cache(lambda: octetvdb.Fit(control, progress=progress,
                                                            **fit_options))
        fluxes = {}
        for frame, gathered in found.items():
            fluxes[frame], boundary, _ = flow.solve(make_fit, control, gathered, walls,
                                                   progress)
        return octetvdb.bake(make_asset(frames=fluxes), path, boundary=boundary, progress=progress,
                             **options)
    return Job(fit_and_bake), frames


def _gather_frames(context, cage, frames):
    scene = context.scene
    before = scene.frame_current
    try:
        found = {}
        for frame in frames:
            scene.frame_set(frame)
            found[frame] = flow.gather(context, cage)
        return found
    finally:
        scene.frame_set(before)


class OCTETVDB_OT_bake(Action, bpy.types.Operator):
    """Bake the flow to an OpenVDB file and show it as a volume. Esc cancels"""
    bl_idname = "octetvdb.bake"
    bl_label = "Bake"

    @classmethod
    def poll(cls, context):
        return not context.scene.octetvdb.task

    def run(self, context):
        cage = current.cage(context)
        job, frames = prepare(context, cage)
        job.run_here()
        return self._finish(context, cage, job, frames)

    def invoke(self, context, event):
        return self._start(context)

    @reported
    def _start(self, context):
        cage = current.cage(context)
        self._job, self._frames = prepare(context, cage)
        self._cage = cage.name
        manager = context.window_manager
        self._timer = manager.event_timer_add(_TICK, window=context.window)
        manager.modal_handler_add(self)
        context.scene.octetvdb.task = "Baking"
        self._job.start()
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            self._job.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        settings = context.scene.octetvdb
        if self._job.running():
            settings.progress = 100 * self._job.fraction
            settings.task = self._job.stage or "Baking"
            self._show(context, f"{settings.task}  {settings.progress:.0f} %   Esc: cancel")
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self._timer)
        settings.task, settings.progress = "", 0
        self._show(context, None)
        return self._finish_modal(context)

    @reported
    def _finish_modal(self, context):
        cage = bpy.data.objects.get(self._cage)
        if cage is None:
            raise Problem(f'the cage "{self._cage}" was deleted while it was baked')
        return self._finish(context, cage, self._job, self._frames)

    def _finish(self, context, cage, job, frames):
        if job.error is not None:
            octetvdb = library.need()
            if isinstance(job.error, octetvdb.Cancelled):
                self.report({"WARNING"}, "Bake cancelled")
                return {"CANCELLED"}
            raise job.error
        files = [file.path for file in job.report.files]
        volume.load(context, cage, files, frames)
        cage.octetvdb.certificate = certificate(job.report)
        self.report({"INFO"}, f"Baked {files[0]}" if len(files) == 1
                    else f"Baked {len(files)} files, {files[0]} and on")
        return {"FINISHED"}

    @staticmethod
    def _show(context, text):
        context.workspace.status_text_set(text)
        for area in context.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def certificate(report):
    """What OpenVDB's operators found in a bake, of the worst frame, one line each. Divergence is times
    voxel size over largest speed."""
    grids = [next(g for g in file.grids if g.name == "velocity") for file in report.files]
    worst = max(grids, key=lambda grid: grid.certificate.max_divergence)
    found = worst.certificate
    return "\n".join([
        f"{found.active_voxels:,} voxels of {worst.voxel_size:.4g}",
        f"Speed up to {found.max_speed:.4g} / s",
        f"Divergence max {found.max_divergence:.1e}",
        f"Divergence RMS {found.rms_divergence:.1e}",
        f"Outflow {found.outflow:.1e} of {found.throughflow:.1e}",
        *([worst.note] if worst.note else [])])


register, unregister = bpy.utils.register_classes_factory((OCTETVDB_OT_bake,))

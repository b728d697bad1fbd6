"""The result of a run, flown here or read from its folder or its bag."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from auv_core.machine.whole_files import write_text
from auv_core.params import ConfigError, shown
from auv_experiment import results
from auv_experiment.figures.formats import FORMATS, PAGE_FORMAT, with_page_format
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.recording import Recording, RecordingError
from auv_experiment.scenario import schema
from auv_experiment.scenario.loading import scenario_to_yaml

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from auv_experiment.figures import Drawer
    from shoal.scenario import Scenario


class Result:
    """
    The result of a run: its scenario and recording; metrics, figures and tables are made on request.

    Attributes
    ----------
    scenario : Scenario
        The resolved scenario.
    recording : Recording
        The recording as NumPy arrays; docs/reference/recording.md describes them.
    mode : str
        'inprocess', 'lockstep' or 'realtime'.

    Examples
    --------
    >>> import shoal
    >>> result = shoal.run("flock_acoustic", duration_s=3.0)
    >>> result.to_xarray()["position_ned_m"].sel(vehicle="auv_1", axis="north").attrs["units"]
    'm'
    >>> "pair_distances" in result.figures
    True

    """

    def __init__(
        self,
        scenario: schema.Scenario,
        recording: Recording,
        *,
        mode: str,
        metrics: dict[str, Any] | None = None,
        real_time_factor: float = math.nan,
    ) -> None:
        self.scenario = scenario
        self.recording = recording
        self.mode = mode
        self._real_time_factor = real_time_factor
        if metrics is not None:
            self.metrics = metrics

    def __repr__(self) -> str:
        run = self.scenario
        return f"<shoal.Result {run.name}, seed {run.seed}, {self.recording.t_s[-1]:g} s, {self.mode}>"

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """The numbers of the report, by name."""
        return compute_metrics(
            self.recording, self.scenario, mode=self.mode, real_time_factor=self._real_time_factor
        )

    @cached_property
    def _drawers(self) -> dict[str, Drawer]:
        from auv_experiment.figures.by_law import run_drawers

        return run_drawers(self.recording, self.scenario)

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures of this kind of run."""
        return tuple(self._drawers)

    def figure(self, name: str) -> Figure:
        """
        Draw a figure of the report.

        Parameters
        ----------
        name : str
            One of `figures`.

        Returns
        -------
        figure : matplotlib.figure.Figure
            A figure without a window; ``savefig`` writes it.

        Raises
        ------
        ConfigError
            If the name is unknown, or this run has no data for the figure; one line.

        Examples
        --------
        >>> import shoal
        >>> figure = shoal.run("flock_acoustic", duration_s=3.0).figure("pair_distances")
        >>> figure.axes[0].get_ylabel()
        'distance between hull centres (m)'

        """
        from auv_experiment.figures.files import draw_in_style

        if name not in self._drawers:
            raise ConfigError(f"figure: {shown(name)} is not allowed; allowed: {', '.join(self._drawers)}")
        drawing = draw_in_style(self._drawers[name])
        if drawing is None:
            raise ConfigError(
                f"figure: {shown(name)} is not allowed; allowed: those that this run has data for"
            )
        return drawing.canvas

    def to_xarray(self) -> xr.Dataset:
        """
        Return the recording as an xarray Dataset with names, units and frames.

        Examples
        --------
        >>> import shoal
        >>> dataset = shoal.run("flock_acoustic", duration_s=3.0).to_xarray()
        >>> dataset["position_ned_m"].dims
        ('time', 'vehicle', 'axis')

        """
        from shoal.arrays import to_xarray

        return to_xarray(self.recording, self.scenario, self.mode)

    def to_pandas(self) -> pd.DataFrame:
        """
        Return the data of every vehicle as a DataFrame, a row for each time (s) and vehicle.

        Examples
        --------
        >>> import shoal
        >>> table = shoal.run("flock_acoustic", duration_s=3.0).to_pandas()
        >>> bool(table.loc[(0.0, "auv_1"), "position_ned_m.down"] > 0.0)
        True

        """
        from shoal.arrays import to_pandas

        return to_pandas(self.recording, self.scenario, self.mode)

    def save(
        self, folder: str | Path, *, with_figures: bool = True, formats: Sequence[str] = (PAGE_FORMAT,)
    ) -> Path:
        """
        Write scenario, recording, metrics, figures and report, as the run command does; return the folder.

        Parameters
        ----------
        folder : str or Path
            A new or an empty folder.
        with_figures : bool
            Whether to draw figures.
        formats : sequence of str
            Formats of the figures: "png", and for one column of a paper "pdf" and "svg". PNG is always made.

        Raises
        ------
        ConfigError
            For another format; one line.
        ResultsError
            If the folder is not empty, or cannot be made; one line.

        """
        if unknown := [name for name in formats if name not in FORMATS]:
            raise ConfigError(f"formats: {shown(unknown[0])} is not allowed; allowed: {', '.join(FORMATS)}")
        place = Path(folder)
        results.make_folder(place)
        if any(place.iterdir()):
            raise results.ResultsError(
                f"folder: {str(place)!r} is not empty; allowed: a new or an empty folder"
            )
        write_text(place / results.SCENARIO_FILE, scenario_to_yaml(self.scenario))
        results.write_json(place / results.PROVENANCE_FILE, results.provenance(self.scenario, mode=self.mode))
        self.recording.save(place / results.RECORDING_FILE)
        factor = self.metrics.get("real_time_factor")
        results.write_results(
            place,
            self.scenario,
            self.recording,
            mode=self.mode,
            real_time_factor=math.nan if factor is None else factor,
            formats=with_page_format(formats) if with_figures else (),
            tell=lambda line: warnings.warn(line, stacklevel=4),
        )
        return place


def open_result(path: str | Path, *, scenario: Scenario | str | Path | None = None) -> Result:
    """
    Return the result of an earlier run.

    Parameters
    ----------
    path : str or Path
        A results folder, its bag (a folder or an .mcap file), or its recording.npz.
    scenario : Scenario, str or Path, optional
        The scenario of the run; by default the scenario.yaml of the results folder.

    Raises
    ------
    ResultsError
        If there is no such run, or it cannot be read; one line.

    Examples
    --------
    >>> import shoal, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     saved = shoal.run("flock_acoustic", duration_s=3.0).save(folder, with_figures=False)
    ...     shoal.open(saved)
    <shoal.Result flock_acoustic, seed 1, 3 s, inprocess>

    """
    from auv_bag.writer import BagError
    from auv_experiment.recording_from_bag import read_recording
    from shoal.scenario import resolve

    place = Path(path)
    if not place.exists():
        raise results.ResultsError(f"path: {str(place)!r} does not exist; allowed: a results folder or a bag")
    folder = _results_folder(place)
    if scenario is None and not (folder / results.SCENARIO_FILE).is_file():
        raise results.ResultsError(
            f"scenario: missing, since there is no {folder / results.SCENARIO_FILE}; allowed: the scenario "
            "of the run"
        )
    resolved = resolve(folder / results.SCENARIO_FILE if scenario is None else scenario)
    try:
        if (file := _recording_file(place)) is not None:
            recording = Recording.load(file)
        else:
            recording = read_recording(place, resolved)
    except (BagError, RecordingError) as error:
        raise results.ResultsError(str(error)) from None
    known = {
        **results.read_json(folder / results.PROVENANCE_FILE),
        **results.read_json(folder / results.METRICS_FILE),
    }
    factor = known.get("real_time_factor")
    return Result(
        resolved,
        recording,
        mode=str(known.get("mode", "lockstep")),
        real_time_factor=float(factor) if isinstance(factor, int | float) else math.nan,
    )


def _results_folder(place: Path) -> Path:
    """Return the results folder of a path, which is the path itself or a folder above it."""
    candidates = (place, place.parent, place.parent.parent)
    return next((folder for folder in candidates if (folder / results.SCENARIO_FILE).is_file()), place)


def _recording_file(place: Path) -> Path | None:
    """Return the .npz file of a path, None for a bag."""
    if place.suffix == ".npz":
        return place
    file = place / results.RECORDING_FILE
    return file if file.is_file() else None

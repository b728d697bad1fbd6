"""The depth of every vehicle over time."""

from auv_experiment.figures import Drawing
from auv_experiment.figures.plotting import legend_below, new_canvas, vehicle_style


def draw(recording, scenario):
    """Return the figure."""
    canvas = new_canvas(3.0)
    axes = canvas.subplots()
    for i, name in enumerate(recording.vehicle_ids):
        axes.plot(recording.t_s, recording.position_ned_m[:, i, 2], label=name, **vehicle_style(i))
    axes.set(xlabel="time (s)", ylabel="depth (m)")
    axes.invert_yaxis()
    legend_below(canvas, *axes.get_legend_handles_labels())
    return Drawing(canvas, "Depths", "Depth of the hull centres, downwards.")

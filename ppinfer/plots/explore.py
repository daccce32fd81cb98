"""A picture with sliders: move one, and the picture is drawn anew."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ppinfer.errors import PPInferError
from ppinfer.plots.palette import quiet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MISSING = "sliders need ipywidgets: pip install 'ppinfer[notebooks]'"
_DPI = 100


def require_widgets() -> Any:
    """Return the package ``ipywidgets``.

    Raises
    ------
    PPInferError
        In one line, where the extra is not installed.

    Examples
    --------
    >>> require_widgets().IntSlider(value=3).value
    3
    """
    try:
        return import_module("ipywidgets")
    except ImportError as error:
        raise PPInferError(MISSING) from error


class Explorer:
    """A picture of values that sliders hold; see `explore`, which makes one.

    Attributes
    ----------
    figure
        The figure, drawn with the values that the sliders hold now; ``figure.savefig`` keeps it.
    axes
        Its axes, left to right.
    controls
        The widgets by name; setting ``controls[name].value`` in a program does what moving it does.
    complaint
        What was wrong with the last move, in one line: then the picture is the one before. "" where nothing was.

    Examples
    --------
    >>> from ipywidgets import IntSlider
    >>> shown = explore(lambda ax, slope: ax.axline((0, 0), slope=slope), slope=IntSlider(value=2))
    >>> isinstance(shown, Explorer), shown.values, shown.complaint
    (True, {'slope': 2}, '')
    """

    def __init__(
        self,
        draw: Callable[..., object],
        controls: dict[str, Any],
        *,
        figsize: tuple[float, float],
        widths: tuple[float, ...],
    ) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        widgets = require_widgets()
        for name, control in controls.items():
            if not isinstance(control, widgets.ValueWidget):
                raise PPInferError(
                    f"explore: {name} is to be a widget that holds a value, such as an ipywidgets.FloatSlider; got "
                    f"{control!r}"
                )
        self.figure: Figure = Figure(figsize=figsize, dpi=_DPI, layout="constrained")
        self._canvas: Any = FigureCanvasAgg(self.figure)
        self.axes: tuple[Axes, ...] = tuple(
            self.figure.subplots(1, len(widths), width_ratios=widths, squeeze=False)[0]
        )
        self.controls = controls
        self._draw = draw
        self._says = widgets.Label()
        self._handle: Any = None
        for control in controls.values():
            if hasattr(control, "description"):
                control.style.description_width = "13em"
                control.layout.width = "36em"
            control.observe(self._moved, names="value")
        self._redraw()
        # the place of everything is settled once: what moves is what the sliders move, and that is twice as fast
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")

    @property
    def values(self) -> dict[str, Any]:
        """What the sliders hold."""
        return {name: control.value for name, control in self.controls.items()}

    @property
    def complaint(self) -> str:
        """What was wrong with the last move."""
        return str(self._says.value)

    def png(self) -> bytes:
        """Return the picture as it is now, as a PNG file."""
        from io import BytesIO

        from matplotlib.image import imsave

        self._canvas.draw()
        with BytesIO() as file:
            imsave(file, self._canvas.buffer_rgba(), format="png", dpi=_DPI)
            return file.getvalue()

    def _redraw(self) -> None:
        for ax in self.axes:
            ax.clear()
        self._draw(*self.axes, **self.values)
        for ax in self.axes:
            quiet(ax)

    def _moved(self, _: object) -> None:
        try:
            self._redraw()
        except PPInferError as error:
            self._says.value = str(error)
            return
        self._says.value = ""
        if self._handle is not None:
            self._handle.update(self._image())

    def _image(self) -> Any:
        return import_module("IPython.display").Image(self.png(), format="png")

    def _ipython_display_(self) -> None:
        """Show the sliders, and the picture below them: an ordinary one, which a page keeps when it is printed."""
        shown = import_module("IPython.display")
        shown.display(require_widgets().VBox([*self.controls.values(), self._says]))
        self._handle = shown.display(self._image(), display_id=True)


def explore(
    draw: Callable[..., object],
    *,
    figsize: tuple[float, float] = (9.0, 3.6),
    widths: tuple[float, ...] = (1.0,),
    **controls: Any,
) -> Explorer:
    """Draw a picture of values that sliders hold, and draw it anew whenever one is moved.

    In a notebook, the last expression of a cell shows the sliders with the picture below.

    Parameters
    ----------
    draw : callable
        Called as ``draw(*axes, **values)`` with cleared axes, one for each of `widths`, and the value of each control.
        What it raises of `PPInferError` on a move is shown beside the sliders, and the picture stays.
    figsize : (float, float)
        Width and height of the picture (inches).
    widths : tuple of float
        Relative widths of its axes, side by side.
    **controls : ipywidgets.ValueWidget
        Sliders, menus and boxes, by the names that `draw` knows their values by.

    Returns
    -------
    Explorer
        The picture, with its figure, axes and controls.

    Raises
    ------
    PPInferError
        Where ipywidgets is not installed (the extra ``notebooks``), or a control is no widget.

    Examples
    --------
    >>> from ipywidgets import FloatSlider
    >>> def belief(ax, *, likelihood_ratio):
    ...     bars = ax.bar(["cup", "pan"], [likelihood_ratio / (1 + likelihood_ratio), 1 / (1 + likelihood_ratio)])
    >>> shown = explore(belief, likelihood_ratio=FloatSlider(value=1.0, min=0.1, max=10.0))
    >>> shown.controls["likelihood_ratio"].value = 4.0
    >>> [float(bar.get_height()) for bar in shown.axes[0].patches]
    [0.8, 0.2]
    """
    return Explorer(draw, controls, figsize=figsize, widths=widths)

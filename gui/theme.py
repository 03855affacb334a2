"""Light and dark: one Qt palette for each, and the colours of the canvas that go with it."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QApplication

from gui.render.colours import DARK, LIGHT, Palette

THEMES = ("system", "light", "dark")


def is_dark(theme: str) -> bool:
    """What "system" means here and now."""
    if theme != "system":
        return theme == "dark"
    return QApplication.styleHints().colorScheme() == Qt.ColorScheme.Dark


def apply_theme(application: QApplication, theme: str) -> Palette:
    """Give all widgets a theme; returns the colours for canvases."""
    dark = is_dark(theme)
    application.setStyle("Fusion")
    application.setPalette(_dark() if dark else _light())
    return DARK if dark else LIGHT


def _light() -> QPalette:
    return _palette(
        window="#f5f6f7", base="#ffffff", other="#eef0f2", text="#16191d", button="#eceef0",
        accent="#0a66d6", faint="#8a929c", tip="#fffbe6",
    )  # fmt: skip


def _dark() -> QPalette:
    return _palette(
        window="#2b3036", base="#1a1d21", other="#23282d", text="#e9ecef", button="#3d444c",
        accent="#3f8fe8", faint="#89929b", tip="#1a1d21",
    )  # fmt: skip


def _palette(
    window: str, base: str, other: str, text: str, button: str, accent: str, faint: str, tip: str
) -> QPalette:
    palette = QPalette()
    roles = {
        QPalette.ColorRole.Window: window,
        QPalette.ColorRole.WindowText: text,
        QPalette.ColorRole.Base: base,
        QPalette.ColorRole.AlternateBase: other,
        QPalette.ColorRole.ToolTipBase: tip,
        QPalette.ColorRole.ToolTipText: text,
        QPalette.ColorRole.Text: text,
        QPalette.ColorRole.Button: button,
        QPalette.ColorRole.ButtonText: text,
        QPalette.ColorRole.PlaceholderText: faint,
        QPalette.ColorRole.Highlight: accent,
        QPalette.ColorRole.HighlightedText: "#ffffff",
        QPalette.ColorRole.Link: accent,
        QPalette.ColorRole.BrightText: "#ff5544",
    }
    for role, colour in roles.items():
        palette.setColor(role, QColor(colour))
    for role in (
        QPalette.ColorRole.Text,
        QPalette.ColorRole.WindowText,
        QPalette.ColorRole.ButtonText,
    ):
        palette.setColor(QPalette.ColorGroup.Disabled, role, QColor(faint))
    return palette

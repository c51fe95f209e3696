"""A display of the X Window System through ctypes: fake input, and pixels read back from the screen.

Reading one pixel costs about 0.1 ms, so that a loop sees a frame when it appears; starting a program costs a hundred
times that.
"""

from __future__ import annotations

import ctypes as c

from pictures import Picture

_Z_PIXMAP = 2
_ALL_PLANES = 0xFFFFFFFF
_LEFT_BUTTON = 1


class XError(Exception):
    """The display cannot be opened, or a window is not there to be read."""


class _Image(c.Structure):
    """The head of `XImage`, as far as it is read here."""

    _fields_ = [
        ("width", c.c_int),
        ("height", c.c_int),
        ("xoffset", c.c_int),
        ("format", c.c_int),
        ("data", c.c_void_p),
        ("byte_order", c.c_int),
        ("bitmap_unit", c.c_int),
        ("bitmap_bit_order", c.c_int),
        ("bitmap_pad", c.c_int),
        ("depth", c.c_int),
        ("bytes_per_line", c.c_int),
        ("bits_per_pixel", c.c_int),
    ]


_HANDLER = c.CFUNCTYPE(c.c_int, c.c_void_p, c.c_void_p)


@_HANDLER
def _keep_silent(_display: int, _event: int) -> int:
    """Instead of Xlib's own handler, which ends the program: a window may vanish between two calls."""
    return 0


def _library() -> tuple[c.CDLL, c.CDLL]:
    try:
        x, test = c.CDLL("libX11.so.6"), c.CDLL("libXtst.so.6")
    except OSError as error:
        raise XError(f"{error} (Debian: apt-get install xdotool)") from error
    x.XOpenDisplay.restype, x.XOpenDisplay.argtypes = c.c_void_p, [c.c_char_p]
    x.XCloseDisplay.argtypes = [c.c_void_p]
    x.XDefaultRootWindow.restype, x.XDefaultRootWindow.argtypes = c.c_ulong, [c.c_void_p]
    x.XSync.argtypes = [c.c_void_p, c.c_int]
    x.XFlush.argtypes = [c.c_void_p]
    x.XFree.argtypes = [c.c_void_p]
    integers = [c.c_int, c.c_int, c.c_uint, c.c_uint]
    x.XGetImage.restype = c.POINTER(_Image)
    x.XGetImage.argtypes = [c.c_void_p, c.c_ulong, *integers, c.c_ulong, c.c_int]
    x.XDestroyImage.argtypes = [c.POINTER(_Image)]
    pointers = [c.POINTER(c.c_int), c.POINTER(c.c_int), c.POINTER(c.c_ulong)]
    x.XTranslateCoordinates.argtypes = [c.c_void_p, c.c_ulong, c.c_ulong, c.c_int, c.c_int, *pointers]
    x.XStringToKeysym.restype, x.XStringToKeysym.argtypes = c.c_ulong, [c.c_char_p]
    x.XKeysymToKeycode.restype, x.XKeysymToKeycode.argtypes = c.c_ubyte, [c.c_void_p, c.c_ulong]
    test.XTestFakeMotionEvent.argtypes = [c.c_void_p, c.c_int, c.c_int, c.c_int, c.c_ulong]
    test.XTestFakeButtonEvent.argtypes = [c.c_void_p, c.c_uint, c.c_int, c.c_ulong]
    test.XTestFakeKeyEvent.argtypes = [c.c_void_p, c.c_uint, c.c_int, c.c_ulong]
    x.XSetErrorHandler(_keep_silent)
    return x, test


class Display:
    """A connection to an X server whose screen has 24 bits a pixel."""

    def __init__(self, name: str) -> None:
        self._x, self._test = _library()
        self._display = self._x.XOpenDisplay(name.encode())
        if not self._display:
            raise XError(f"cannot open the display {name}")
        self.root = self._x.XDefaultRootWindow(self._display)

    def close(self) -> None:
        """Ends the connection."""
        self._x.XCloseDisplay(self._display)

    def grab(self, window: int, x: int, y: int, width: int, height: int) -> Picture:
        """What the screen shows of a part of a window. The part must lie on the screen."""
        image = self._x.XGetImage(self._display, window, x, y, width, height, _ALL_PLANES, _Z_PIXMAP)
        if not image:
            raise XError(f"window {window:#x} shows no {width} x {height} pixels at {x}, {y}")
        try:
            head = image.contents
            if head.bits_per_pixel != 32 or head.byte_order != 0:
                raise XError(f"{head.bits_per_pixel} bits a pixel, byte order {head.byte_order}: not 32 and 0")
            return Picture.of_bgrx(width, height, c.string_at(head.data, height * head.bytes_per_line))
        finally:
            self._x.XDestroyImage(image)

    def pixel(self, window: int, x: int, y: int) -> tuple[int, int, int]:
        """Red, green and blue of one pixel of a window."""
        red, green, blue = self.grab(window, x, y, 1, 1).data
        return red, green, blue

    def origin(self, window: int) -> tuple[int, int]:
        """Where the window's upper left corner lies on the screen."""
        x, y, child = c.c_int(), c.c_int(), c.c_ulong()
        out = (c.byref(x), c.byref(y), c.byref(child))
        if not self._x.XTranslateCoordinates(self._display, window, self.root, 0, 0, *out):
            raise XError(f"there is no window {window:#x}")
        return x.value, y.value

    def move(self, x: int, y: int) -> None:
        """Moves the pointer to a point of the screen."""
        self._test.XTestFakeMotionEvent(self._display, -1, x, y, 0)
        self._x.XFlush(self._display)

    def button(self, down: bool) -> None:
        """Presses or releases the left button."""
        self._test.XTestFakeButtonEvent(self._display, _LEFT_BUTTON, int(down), 0)
        self._x.XFlush(self._display)

    def key(self, name: str) -> None:
        """Presses and releases the key with that name of X, for the window that has the focus."""
        code = self._x.XKeysymToKeycode(self._display, self._x.XStringToKeysym(name.encode()))
        for down in (1, 0):
            self._test.XTestFakeKeyEvent(self._display, code, down, 0)
        self._x.XFlush(self._display)

"""How the power of signals is shared out among frequencies."""

import numpy as np

from cdp_ident.arrays import Array


def power_spectrum(signals: Array, rate: float, segment: int) -> tuple[Array, Array]:
    """Return frequencies (f,) [Hz] and the power density (f, k) at them of evenly spaced signals (n, k).

    It is the mean over segments of so many samples that overlap by half, each less its mean and under Hann's window
    (Welch, IEEE Trans. Audio Electroacoust. 15, 1967). `scipy.signal.welch` gives the same, but to load it takes
    longer than all else of scipy.

    Args:
        signals: what was measured.
        rate: samples in a second [Hz].
        segment: number of samples in a segment, not more than there are; two at least.
    """
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi / segment * np.arange(segment))
    apart = segment - segment // 2
    segments = np.lib.stride_tricks.sliding_window_view(signals, segment, axis=0)[::apart]
    changes = segments - segments.mean(axis=-1, keepdims=True)
    squares = np.abs(np.fft.rfft(changes * window)) ** 2
    power = np.moveaxis(squares.mean(axis=0), -1, 0) / (rate * np.sum(window**2))
    # Negative frequencies have as much as positive ones.
    power[1 : (segment + 1) // 2] *= 2.0
    return np.asarray(np.fft.rfftfreq(segment, 1.0 / rate)), np.asarray(power)

"""The filters of channel frequency classes: scipy's, the corridor of SAE J211, and bad input."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from contiga.criteria import cfc
from contiga.criteria.filters import CLASSES
from contiga.criteria.kernels.two_poles_nb import forward_and_back
from contiga.errors import InputError

RNG = np.random.default_rng(0)
short = pytest.mark.filterwarnings("ignore:the signal is shorter than the memory")


def gain(cls: int, frequency: float, rate: float) -> float:
    """Of a long sine, measured over whole periods in its middle, in dB."""
    times = np.arange(int(rate * (0.4 + 40.0 / frequency))) / rate
    sine = np.exp(2j * np.pi * frequency * times)
    passed = cfc(np.stack([sine.real, sine.imag], axis=1), 1.0 / rate, cls) @ [1.0, 1.0j]
    k = len(times) // 2
    ratio = passed[k] / sine[k]
    assert abs(ratio.imag) < 1e-9, "a shift in time"
    return float(20.0 * np.log10(ratio.real))


@short
@pytest.mark.parametrize("cls", CLASSES)
@pytest.mark.parametrize("rate", [1e4, 5e4])
@pytest.mark.parametrize("n", [3, 150, 5000])
def test_it_is_the_butterworth_filter_of_scipy(cls, rate, n):
    from scipy.signal import butter, sosfiltfilt

    signal = 40.0 + RNG.normal(size=(n, 2)).cumsum(axis=0)
    sos = butter(2, 2.0775 * cls, fs=rate, output="sos")
    pad = min(max(int(0.01 * rate), 100), n - 1)
    theirs = sosfiltfilt(sos, signal, axis=0, padtype="odd", padlen=pad)
    assert np.abs(cfc(signal, 1.0 / rate, cls) - theirs).max() < 1e-9 * np.abs(signal).max()


@short
@pytest.mark.parametrize("n", [1, 2, 3, 400])
def test_the_order_in_memory_does_not_matter(n):
    signal = RNG.normal(size=(n, 3))
    for laid in (np.asfortranarray(signal), signal[:, ::-1][:, ::-1], signal[::-1][::-1]):
        assert np.array_equal(cfc(laid, 1e-4, 600), cfc(signal, 1e-4, 600))
    assert len(getattr(forward_and_back, "signatures", [0])) == 1  # as compiled kernels have them


@pytest.mark.parametrize("cls", CLASSES)
def test_gains_lie_in_the_corridor_of_the_standard(cls):
    """SAE J211-1, figure 1: ±0.5 dB, then −1 dB, −4 dB, and from 9 to 24 dB an octave."""
    rate = 20.0 * cls
    assert abs(gain(cls, 0.1 * cls, rate)) < 0.5
    assert -1.0 < gain(cls, cls, rate) < 0.5
    assert -4.0 < gain(cls, 1.65 * cls, rate) < 0.5
    for octaves in (0.3, 0.7, 1.1):
        actual = gain(cls, 1.65 * cls * 2.0**octaves, rate)
        assert -4.0 - 24.0 * octaves < actual < 0.5 - 9.0 * octaves


@pytest.mark.parametrize("cls", CLASSES)
def test_half_the_power_passes_at_the_class_over_0_6(cls):
    assert gain(cls, cls / 0.6, 200.0 * cls) == pytest.approx(-3.01, abs=0.02)


def test_a_pulse_stays_where_it_is():
    times = np.linspace(-0.05, 0.05, 1001)
    passed = cfc(np.exp(-((times / 0.004) ** 2)), 1e-4, 180)
    assert np.argmax(passed) == 500
    assert np.abs(passed - passed[::-1]).max() < 1e-12


@pytest.mark.parametrize("value", [0.0, 9.81, -1e6])
def test_constants_stay_as_they_are_to_the_last_bit(value):
    assert np.array_equal(cfc(np.full(400, value), 1e-4, 60), np.full(400, value))


@pytest.mark.parametrize("cls", CLASSES)
def test_straight_lines_do_not_ring_at_their_ends(cls):
    line = 50.0 - 300.0 * np.arange(500) * 1e-4
    # What is left of a class of 60 after 10 ms.
    assert np.abs(cfc(line, 1e-4, cls) - line).max() < (2e-3 if cls == 60 else 1e-6)


def test_filters_add_up():
    one, other = RNG.normal(size=(2, 300))
    both = cfc(2.0 * one - 3.0 * other, 1e-4, 600)
    assert np.abs(both - 2.0 * cfc(one, 1e-4, 600) + 3.0 * cfc(other, 1e-4, 600)).max() < 1e-13


def test_columns_are_channels():
    signal = RNG.normal(size=(200, 3))
    together = cfc(signal, 1e-4, "CFC180")
    assert together.shape == signal.shape
    for k in range(3):
        assert np.array_equal(together[:, k], cfc(signal[:, k], 1e-4, 180))


@pytest.mark.parametrize("cls", [1000, "1000", "CFC1000", "cfc1000", "CFC 1000", 1000.0])
def test_classes_may_be_written_in_several_ways(cls):
    signal = RNG.normal(size=50)
    assert np.array_equal(cfc(signal, 1e-4, cls), cfc(signal, 1e-4, 1000))


def test_one_sample_is_a_constant():
    assert cfc([3.0], 1e-4, 60).tolist() == [3.0]


@short
def test_what_is_given_is_not_changed():
    signal = RNG.normal(size=50)
    before = signal.copy()
    cfc(signal, 1e-4, 60)
    assert np.array_equal(signal, before)


@pytest.mark.parametrize("cls", [100, "CFC", "CFC1001", None, True, 60.5, [60]])
def test_unknown_classes_are_refused(cls):
    with pytest.raises(InputError, match=r"cfc, cls: an unknown channel.*60, 180, 600, 1000"):
        cfc([1.0, 2.0], 1e-4, cls)


def test_coarse_samples_are_refused_with_the_number():
    cfc(np.zeros(9), 1e-4, 1000)
    with pytest.raises(
        InputError, match=r"too few samples for CFC1000; found 0.000101; .*0.0001 s"
    ):
        cfc(np.zeros(9), 1.01e-4, 1000)


@pytest.mark.parametrize("dt", [0.0, -1e-4, np.nan, "1e-4s"])
def test_steps_are_positive(dt):
    with pytest.raises(InputError, match="cfc, dt: must be"):
        cfc([1.0, 2.0], dt, 60)


@pytest.mark.parametrize(
    ("signal", "says"),
    [
        ([1.0, np.nan, 2.0], "sample 1 is not finite; found nan"),
        ([[1.0, 2.0], [3.0, np.inf]], r"sample 1 is not finite; found \[3.0, inf\]"),
        ([], r"a signal must have samples; found \(0,\)"),
        (5.0, "a signal must have samples"),
        (np.zeros((2, 2, 2)), "a signal must have samples"),
        (["a"], "must be an array of numbers"),
    ],
    ids=range(6),
)
def test_bad_signals_are_refused(signal, says):
    with pytest.raises(InputError, match=f"cfc, signal: {says}"):
        cfc(signal, 1e-4, 60)


def test_a_signal_shorter_than_the_memory_is_told_of():
    """Cut out of a long signal, its ends come out otherwise; a longer one's hardly do."""
    dt, cls, size = 1e-5, 180, 100.0
    for memories, told in ((0.5, True), (1.5, False)):
        count = int(memories * 0.75 / cls / dt) + 1
        period = 2.0 * (count - 1) * dt
        times = np.arange(-5 * count, 6 * count) * dt
        wave = size * np.sin(2.0 * np.pi * times / period)
        truth = cfc(wave, dt, cls)[5 * count : 6 * count]
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            cut = cfc(wave[5 * count : 6 * count], dt, cls)
        assert [str(one.message)[:10] for one in heard] == ["the signal"] * told
        off = np.abs(cut - truth).max()
        assert (off > 1e-2 * size) == told
        assert told or off < 2e-3 * size

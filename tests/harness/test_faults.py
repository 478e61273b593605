# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodestar import channels
from lodestar.harness.faults import KINDS, Fault, check_fault, inject, raw_payloads
from lodestar.harness.scenario import load_scenario, simulate


@pytest.fixture(scope="module")
def flight():
    scenario = load_scenario("ordinary")
    gps = replace(scenario.gps, velocity=True)
    return simulate(replace(scenario, duration_s=30.0, gps=gps), 1)


def window(channel, start, end):
    return (channel["time_us"] >= start * 1e6) & (channel["time_us"] < end * 1e6)


def faulty(flight, fault, seed=1):
    check_fault(fault)
    return inject(flight, [fault], seed)[fault.channel]


def unchanged_elsewhere(flight, fault, fields):
    """Assert that nothing but these fields within the window is touched; return both channels."""
    before = {name: values.copy() for name, values in flight[fault.channel].items()}
    after = inject(flight, [fault], 1)
    hit = window(before, fault.start_s, fault.start_s + fault.duration_s)
    for name, values in before.items():
        np.testing.assert_array_equal(flight[fault.channel][name], values)  # input is not touched
        kept = ~hit if name in fields else slice(None)
        np.testing.assert_array_equal(after[fault.channel][name][kept], values[kept])
    for channel in flight.channels:
        if channel != fault.channel:
            assert after[channel] is flight[channel]
    return before, after[fault.channel], hit


def test_dropout_removes_the_messages_of_the_window(flight):
    fault = Fault("dropout", "ADC", 10.0, 5.0)
    kept = faulty(flight, fault)
    assert len(kept["time_us"]) == len(flight["ADC"]["time_us"]) - 150
    assert not window(kept, 10.0, 15.0).any()


def test_fault_without_a_duration_lasts_to_the_end(flight):
    assert faulty(flight, Fault("dropout", "ADC", 10.0))["time_us"][-1] < 10e6


def test_freeze_repeats_the_last_good_values_while_time_goes_on(flight):
    fault = Fault("freeze", "SMDU", 10.0, 5.0)
    before, after, hit = unchanged_elsewhere(flight, fault, ["b_B"])
    last_good = before["b_B"][np.argmax(hit) - 1]
    np.testing.assert_array_equal(after["b_B"][hit], np.tile(last_good, (150, 1)))


def test_bias_and_ramp_add_on_the_chosen_axis(flight):
    bias = Fault("bias", "EFCS.RATES", 10.0, 5.0, "omega_B", axis=2, value=0.1)
    before, after, hit = unchanged_elsewhere(flight, bias, ["omega_B"])
    step = (after["omega_B"] - before["omega_B"])[hit]
    np.testing.assert_allclose(step, np.tile([0, 0, 0.1], (300, 1)), atol=1e-15)

    ramp = Fault("ramp", "ADC", 10.0, 5.0, "true_airspeed", value=2.0)
    before, after, hit = unchanged_elsewhere(flight, ramp, ["true_airspeed"])
    grown = (after["true_airspeed"] - before["true_airspeed"])[hit]
    np.testing.assert_allclose(grown, 2.0 * (before["time_us"][hit] * 1e-6 - 10.0), atol=1e-9)


def test_noise_becomes_as_many_times_as_strong_as_asked_for(flight):
    fault = Fault("noise", "EFCS.LOAD_FACTOR", 5.0, 20.0, "n_B", value=5.0)
    before, after, hit = unchanged_elsewhere(flight, fault, ["n_B"])

    def sigma(values):
        return np.std(np.diff(values[hit], n=3, axis=0), axis=0) / np.sqrt(20)

    # 1200 samples: 3 % on each sigma.
    np.testing.assert_allclose(sigma(after["n_B"]) / sigma(before["n_B"]), 5.0, rtol=0.15)


def test_spike_hits_one_message_per_interval(flight):
    fault = Fault("spike", "ADC", 10.0, 5.0, "baro_altitude", value=300.0, interval_s=2.0)
    before, after, _ = unchanged_elsewhere(flight, fault, ["baro_altitude"])
    off = after["baro_altitude"] - before["baro_altitude"]
    spikes = np.flatnonzero(off)
    np.testing.assert_allclose(off[spikes], 300.0)
    np.testing.assert_allclose(before["time_us"][spikes] * 1e-6, [10.0, 12.0, 14.0], atol=1e-6)


def test_saturation_stops_the_values_at_both_ends(flight):
    fault = Fault("saturate", "EFCS.RATES", 10.0, 5.0, "omega_B", axis=1, value=0.001)
    before, after, hit = unchanged_elsewhere(flight, fault, ["omega_B"])
    clipped = np.clip(before["omega_B"][hit, 1], -0.001, 0.001)
    assert (np.abs(before["omega_B"][hit, 1]) > 0.001).any()
    np.testing.assert_array_equal(after["omega_B"][hit, 1], clipped)
    np.testing.assert_array_equal(after["omega_B"][:, ::2], before["omega_B"][:, ::2])


def test_nan_replaces_the_chosen_or_all_values(flight):
    one = faulty(flight, Fault("nan", "SMDU", 10.0, 5.0, "b_B", axis=1))
    hit = window(one, 10.0, 15.0)
    np.testing.assert_array_equal(np.isnan(one["b_B"]), np.outer(hit, [False, True, False]))
    everything = faulty(flight, Fault("nan", "ADC", 10.0, 5.0))
    for name in ("true_airspeed", "alpha", "beta", "baro_altitude", "static_temperature"):
        np.testing.assert_array_equal(np.isnan(everything[name]), hit)


def test_time_jump_moves_time_stamps_and_not_arrival(flight):
    fault = Fault("time_jump", "ADC", 10.0, 5.0, value=-0.5)
    before, after, hit = unchanged_elsewhere(flight, fault, ["time_us"])
    assert (before["time_us"][hit] - after["time_us"][hit] == 500_000).all()


def test_duplicate_sends_each_message_twice_in_a_row(flight):
    twice = faulty(flight, Fault("duplicate", "GPS", 10.0, 5.0))
    times = twice["time_us"][(twice["time_us"] >= 9e6) & (twice["time_us"] <= 16e6)] // 1_000_000
    assert times.tolist() == [9, 10, 10, 11, 11, 12, 12, 13, 13, 14, 14, 15, 16]


def test_out_of_order_swaps_neighbours(flight):
    swapped = faulty(flight, Fault("out_of_order", "ADC", 10.0, 1.0))
    order = np.diff(swapped["time_us"])
    assert (np.diff(swapped["arrival_us"]) >= 0).all()
    assert np.sum(order < 0) == 15
    assert sorted(swapped["time_us"]) == flight["ADC"]["time_us"].tolist()


def test_spoof_drags_position_and_velocity_off_along_the_bearing(flight):
    fault = Fault("spoof", "GPS", 10.0, 20.0, value=3.0, bearing_deg=90.0)
    before, after, hit = unchanged_elsewhere(flight, fault, ["lat", "lon", "v_N"])
    east = (after["lon"] - before["lon"])[hit] * 6.39e6 * np.cos(before["lat"][hit])
    np.testing.assert_allclose(east, 3.0 * (before["time_us"][hit] * 1e-6 - 10.0), rtol=1e-3)
    np.testing.assert_allclose(after["lat"], before["lat"], atol=1e-12)
    drift = (after["v_N"] - before["v_N"])[hit]
    np.testing.assert_allclose(drift, np.tile([0, 3, 0], (20, 1)), atol=1e-12)


def test_malformed_datagrams_are_none_of_them_a_good_message():
    fault = Fault("malformed", "ADC", 5.0, 12.0, interval_s=1.0)
    payloads = raw_payloads([fault], 1, 100.0)
    assert [p.arrival_us for p in payloads] == [1_000_000 * s for s in range(5, 17)]
    message = channels.CHANNELS["ADC"]
    size = len(message().encode())
    fingerprint = message._get_packed_fingerprint()
    for payload in payloads:
        assert payload.channel == "ADC"
        assert len(payload.data) != size or payload.data[:8] != fingerprint
    assert {len(p.data) for p in payloads} > {0, size, 60_008}
    assert payloads == raw_payloads([fault], 1, 100.0)
    assert payloads != raw_payloads([fault], 2, 100.0)
    assert raw_payloads([fault], 1, 8.0) == payloads[:3]


def test_malformed_leaves_the_recording_as_it_is(flight):
    assert inject(flight, [Fault("malformed", "ADC", 5.0, 5.0)], 1) == flight


def test_faults_add_up_in_order(flight):
    bias = Fault("bias", "ADC", 10.0, 5.0, "alpha", value=0.1)
    twice = inject(flight, [bias, bias], 1)["ADC"]["alpha"]
    hit = window(flight["ADC"], 10.0, 15.0)
    np.testing.assert_allclose((twice - flight["ADC"]["alpha"])[hit], 0.2, atol=1e-12)


@settings(deadline=None)
@given(
    kind=st.sampled_from(sorted(set(KINDS) - {"malformed"})),
    channel=st.sampled_from(["EFCS.RATES", "ADC", "GPS", "INS"]),
    start=st.floats(0, 40),
    duration=st.floats(0, 40),
)
def test_any_fault_leaves_a_recording_in_order_of_arrival(flight, kind, channel, start, duration):
    field = {"EFCS.RATES": "omega_B", "ADC": "alpha", "GPS": "lat", "INS": "v_N"}[channel]
    fault = Fault(
        kind,
        "GPS" if kind == "spoof" else channel,
        start,
        duration,
        field="" if kind == "spoof" or not KINDS[kind].field else field,
        value=2.0 if KINDS[kind].value else 0.0,
    )
    result = faulty(flight, fault)
    assert (np.diff(result["arrival_us"]) >= 0).all()
    assert len({len(values) for values in result.values()}) == 1
    again = faulty(flight, fault)
    for name, values in result.items():
        np.testing.assert_array_equal(again[name], values)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (Fault("bias", "ADC", 1.0, field="beta"), r"bias needs a value \(unit of the field\)"),
        (Fault("bias", "ADC", 1.0, field="gamma", value=1.0), "field 'gamma': ADC has true_air"),
        (Fault("ramp", "ADC", 1.0, value=1.0), "ramp needs a field: one of true_airspeed"),
        (Fault("saturate", "SMDU", 0.0, field="b_B", value=-1.0), "value above 0"),
        (Fault("noise", "ADC", 1.0, value=0.5), "noise needs a value above 1"),
        (Fault("dropout", "ADC", 1.0, field="beta"), "dropout takes no field"),
        (Fault("spoof", "ADC", 1.0, value=1.0), "spoof is for channel GPS only"),
    ],
)
def test_keys_that_do_not_fit_together_are_refused(fault, message):
    with pytest.raises(ValueError, match=message):
        check_fault(fault)

"""The chart of the sensor's health: for boards that send SENSOR frames, without ages that nobody knows."""

import numpy as np
import synthetic_run

from host.record.collector import Collector
from host.record.run_data import SENSOR_COLUMNS
from host.report.charts import charts

UNKNOWN = 65_535.0


def keys(data):
    return [chart.key for chart in charts(data)]


def rows(count, age_us):
    table = np.zeros((count, len(SENSOR_COLUMNS)))
    table[:, SENSOR_COLUMNS.index("t_s")] = np.arange(count)
    table[:, SENSOR_COLUMNS.index("supply_mv")] = 5_000.0
    for name in ("age_least_us", "age_most_us"):
        table[:, SENSOR_COLUMNS.index(name)] = age_us
    return table


def test_only_boards_that_tell_have_it():
    assert "sensor" not in keys(synthetic_run.run(None).data)


def test_its_columns_are_there_and_unknown_ages_are_left_out():
    collector = Collector()
    collector.add_sensor(rows(3, UNKNOWN))
    told = rows(2, 700.0)
    collector.add_sensor(told)
    assert (told == rows(2, 700.0)).all()
    data = collector.data
    (chart,) = [chart for chart in charts(data) if chart.key == "sensor"]
    for trace in chart.traces:
        for axis in ("x", "y"):
            series, _, name = trace[axis]["$"].partition(".")
            assert series == "sensor"
            assert len(data.sensor.column(name)) == 5
    for name in ("age_least_us", "age_most_us"):
        np.testing.assert_array_equal(data.sensor.column(name), [np.nan] * 3 + [700.0] * 2)

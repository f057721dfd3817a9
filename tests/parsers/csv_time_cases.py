"""Tables whose time is told in every way that cogest knows, with the nanoseconds that it is."""

from __future__ import annotations

from parsers.importer import ReadOptions

TIMES: dict[str, tuple[str, ReadOptions, list[int]]] = {
    "ms": ("Time (ms),a\n0,1\n10,1\n20,1\n", ReadOptions(), [0, 10_000_000, 20_000_000]),
    "us name": ("timestamp_us,a\n0,1\n10,1\n20,1\n", ReadOptions(), [0, 10_000, 20_000]),
    "epoch s": (
        "timestamp,a\n1397205536.123456789,1\n1397205537.5,1\n",
        ReadOptions(),
        [1397205536123456789, 1397205537500000000],
    ),
    "epoch ms": (
        "timestamp,a\n1397205536123,1\n1397205537500,1\n",
        ReadOptions(),
        [1397205536123000000, 1397205537500000000],
    ),
    "epoch us": (
        "timestamp,a\n1397205536123456,1\n1397205537500000,1\n",
        ReadOptions(),
        [1397205536123456000, 1397205537500000000],
    ),
    "epoch ns": (
        "timestamp,a\n1397205536123456789,1\n1397205537500000001,1\n",
        ReadOptions(),
        [1397205536123456789, 1397205537500000001],
    ),
    "rostopic": (
        "%time,field.header.seq,field.header.stamp,a\n1500000000000000009,4,1500000000000000001,1\n1500000000500000009,5,1500000000500000002,1\n",
        ReadOptions(),
        [1500000000000000001, 1500000000500000002],
    ),
    "stamp pair": (
        "Time,header.seq,header.stamp.secs,header.stamp.nsecs,a\n9.5,1,1500000000,7,1\n10.5,2,1500000000,999999999,1\n",
        ReadOptions(),
        [1500000000000000007, 1500000000999999999],
    ),
    "bare pair": (
        "sec,nanosec,a\n1500000000,7,1\n1500000000,999999999,1\n",
        ReadOptions(),
        [1500000000000000007, 1500000000999999999],
    ),
    "named": (
        "x,weird,a\n5,0.5,1\n5,1.5,1\n",
        ReadOptions(time_channel="weird", time_unit="s"),
        [500000000, 1500000000],
    ),
    "named by header": (
        "x,weird [ms],a\n5,0.5,1\n5,1.5,1\n",
        ReadOptions(time_channel="weird [ms]"),
        [500000, 1500000],
    ),
    "named beats unit": (
        "t [s],a\n1,1\n2,1\n",
        ReadOptions(time_channel="t", time_unit="ms"),
        [1000000, 2000000],
    ),
    "iso": (
        "when,a\n2014-04-11T08:38:56.3Z,1\n2014-04-11T08:38:57.25Z,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "iso zone": (
        "when,a\n2014-04-11T10:38:56.3+02:00,1\n2014-04-11T03:08:57.25-0530,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "iso blank": (
        "time,a\n2014-04-11 08:38:56.300,1\n2014-04-11 08:38:57.250,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "two columns": (
        "Date;Time;a\n11.04.2014;08:38:56,300;1\n11.04.2014;08:38:57,250;2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "american": (
        "DateTime,a\n04/11/2014 08:38:56.3 PM,1\n04/13/2014 12:00:00 AM,2\n",
        ReadOptions(),
        [1397248736300000000, 1397347200000000000],
    ),
    "american without a day beyond 12": (
        "Date,Time,a\n05/01/2024,11:59:59.5 PM,1\n05/02/2024,12:00:00.5 AM,2\n",
        ReadOptions(),
        [1714607999500000000, 1714608000500000000],
    ),
    "durations of MATLAB": (
        "Time,a\n0 sec,1\n0.02 sec,2\n1e-1 sec,3\n",
        ReadOptions(),
        [0, 20_000_000, 100_000_000],
    ),
    "durations in minutes": (
        "Time,a\n0.5 min,1\n1.5 min,2\n",
        ReadOptions(),
        [30_000_000_000, 90_000_000_000],
    ),
    "month by name": (
        "t,a\n11-Apr-2014 08:38:56.300,1\n11-Apr-2014 08:38:57.250,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "month by name, German": (
        "Datum;Zeit;a\n01-Okt-2014;00:00:00,5;1\n01-Okt-2014;00:00:01,5;2\n",
        ReadOptions(),
        [1412121600500000000, 1412121601500000000],
    ),
    "Fortran": (
        "time a\n0.0D+00 1.0D+00\n2.0D-02 1.5D+00\n4.0D-02 2.0D+00\n",
        ReadOptions(),
        [0, 20_000_000, 40_000_000],
    ),
    "seconds elapsed": (
        "seconds_elapsed,z,y,x\n0.5,1,1,1\n1.5,1,1,1\n",
        ReadOptions(),
        [500000000, 1500000000],
    ),
    "minutes and seconds": (
        "time,a\n03:00.000,1\n03:00.020,2\n03:59.5,3\n",
        ReadOptions(),
        [180_000_000_000, 180_020_000_000, 239_500_000_000],
    ),
    "minutes and seconds that the map file names": (
        "x;a\n03:00,000;1\n03:00,020;2\n03:59,5;3\n",
        ReadOptions(time_channel="x"),
        [180_000_000_000, 180_020_000_000, 239_500_000_000],
    ),
    "minutes and seconds that start again with the hour": (
        "time,a\n59:59.0,1\n59:59.5,2\n00:00.0,3\n00:00.5,4\n",
        ReadOptions(),
        [3599_000_000_000, 3599_500_000_000, 3600_000_000_000, 3600_500_000_000],
    ),
    "minutes and seconds that go on with hours": (
        "time,a\n59:59.0,1\n59:59.5,2\n1:00:00.0,3\n61:00.5,4\n-0:01.5,5\n",
        ReadOptions(),
        [3599_000_000_000, 3599_500_000_000, 3600_000_000_000, 3660_500_000_000, -1_500_000_000],
    ),
    "timedelta of pandas": (
        "time,a\n-1 days +23:59:59.980000,1\n0 days 00:00:00,2\n0 days 00:00:00.020000,3\n1 days 00:00:00.5,4\n",
        ReadOptions(),
        [-20_000_000, 0, 20_000_000, 86_400_500_000_000],
    ),
    "timedelta of Python": (
        "time;a\n1 day, 0:00:00;1\n1 day, 0:00:00.020000;2\n2 days, 0:00:00;3\n",
        ReadOptions(),
        [86_400_000_000_000, 86_400_020_000_000, 172_800_000_000_000],
    ),
    "time of day": (
        "Time,a\n23:59:59.5,1\n00:00:00.5,2\n00:00:01.5,2\n",
        ReadOptions(),
        [86399500000000, 86400500000000, 86401500000000],
    ),
    "spelt as a number": (
        "Time,a\n20140411083856.300,1\n20140411083857.250,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "spelt as a whole number": (
        "Time,a\n20140411083856300,1\n20140411083857250,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "date without signs": (
        "Time,a\n20140411 08:38:56.300,1\n20140411 08:38:57.250,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "date and time without signs": (
        "Time,a\n20140411_083856.300,1\n20140411_083857.250,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "times with points": (
        "Time;a\n11-04-2014 08.38.56,300;1\n11-04-2014 08.38.57,250;2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "zone by name": (
        "Time,a\n2014-04-11 08:38:56.300 CET,1\n2014-04-11 08:38:57.250 CET,2\n",
        ReadOptions(),
        [1397201936300000000, 1397201937250000000],
    ),
    "zone of the summer": (
        "Time;a\n11.04.2014 08:38:56,300 MESZ;1\n11.04.2014 08:38:57,250 MESZ;2\n",
        ReadOptions(),
        [1397198336300000000, 1397198337250000000],
    ),
    "zone by name and offset": (
        "Time,a\n2014-04-11 08:38:56.300 UTC+2,1\n2014-04-11 08:38:57.250 UTC+2,2\n",
        ReadOptions(),
        [1397198336300000000, 1397198337250000000],
    ),
    "zone that means several": (
        "Time,a\n2014-04-11 08:38:56.300 CST,1\n2014-04-11 08:38:57.250 CST,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "ctime": (
        "Time,a\nFri Apr 11 08:38:56.300000 2014,1\nFri Apr 11 08:38:57.250000 2014,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "the shell's date": (
        "Time,a\nFri Apr 11 08:38:56.300 CEST 2014,1\nFri Apr 11 08:38:57.250 CEST 2014,2\n",
        ReadOptions(),
        [1397198336300000000, 1397198337250000000],
    ),
    "mail's date": (
        "Time;a\nFri, 11 Apr 2014 08:38:56.300 +0100;1\nFri, 11 Apr 2014 08:38:57.250 +0100;2\n",
        ReadOptions(),
        [1397201936300000000, 1397201937250000000],
    ),
    "American month by name": (
        "Time;a\nApr 11, 2014 08:38:56.300 AM;1\nApr 11, 2014 08:38:57.250 AM;2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "month in German": (
        "Zeit;a\n11. April 2014 08:38:56,300;1\n11. April 2014 08:38:57,250;2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "month in French": (
        "Temps;a\n11 avril 2014 08:38:56,300;1\n11 avr. 2014 08:38:57,250;2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "French day of the week": (
        "Temps;a\nven. 11 avril 2014 08:38:56,300;1\nven. 11 avril 2014 08:38:57,250;2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "Japanese": (
        "Time,a\n2014年04月11日 08時38分56.300秒,1\n2014年4月11日 8時38分57.250秒,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "Japanese date": (
        "Time,a\n2014年04月11日 08:38:56.300,1\n2014年04月11日 08:38:57.250,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "two columns, times with points": (
        "Date;Time;a\n11.04.2014;08.38.56,300;1\n11.04.2014;08.38.57,250;2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "a counter beside a date spelt as a number": (
        "t,datetime,a\n0.5,20140411083856,1\n1.5,20140411083857,2\n",
        ReadOptions(),
        [500_000_000, 1_500_000_000],
    ),
    "a number of 14 digits with a unit": (
        "Time [us],a\n20140411083856,1\n20140411083857,2\n",
        ReadOptions(),
        [20140411083856000, 20140411083857000],
    ),
}
"""Name -> (the table, how it is read, its rows' times)."""

# SPDX-License-Identifier: Apache-2.0
# A round trip of 100 min from Linköping, counterclockwise about the lake Vänern: straight for
# 1500 s, turning until about 5000 s, and straight home.
start                lat 58.4 deg  lon 15.7 deg  altitude 2000 m  heading 325 deg  speed 160 m/s

# North-west, with slight turns
straight             420 s
horizontal_turn      left 12 deg  bank 20 deg
climb                to 3000 m  angle 3 deg
straight             330 s
horizontal_turn      left 8 deg  bank 15 deg
straight             400 s
horizontal_turn      right 10 deg  bank 20 deg
straight             160 s

# West of the lake, southwards, turning
horizontal_turn      left 90 deg  bank 35 deg
straight             40 s
horizontal_turn      left 45 deg  bank 30 deg
straight             60 s
horizontal_turn      right 360 deg  bank 30 deg
straight             90 s
climb                to 2400 m  angle 3 deg
heading_oscillation  amplitude 20 deg  period 60 s  cycles 4
horizontal_turn      left 180 deg  bank 25 deg
straight             60 s
horizontal_turn      right 180 deg  bank 40 deg
straight             120 s
horizontal_turn      left 360 deg  bank 45 deg
speed_change         to 190 m/s  in 40 s
straight             100 s
horizontal_turn      right 90 deg  bank 30 deg
straight             60 s
horizontal_turn      left 180 deg  bank 30 deg
straight             80 s
horizontal_turn      right 90 deg  bank 35 deg
climb                to 3200 m  angle 4 deg
heading_oscillation  amplitude 15 deg  period 50 s  cycles 3
horizontal_turn      left 180 deg  bank 40 deg
straight             90 s
speed_change         to 170 m/s  in 60 s
horizontal_turn      right 270 deg  bank 35 deg
straight             90 s
horizontal_turn      left 360 deg  bank 30 deg
straight             60 s
horizontal_turn      right 270 deg  bank 40 deg
climb                to 2500 m  angle 3 deg
straight             60 s
horizontal_turn      right 150 deg  bank 35 deg
heading_oscillation  amplitude 15 deg  period 60 s  cycles 4
horizontal_turn      left 200 deg  bank 35 deg
straight             60 s
horizontal_turn      right 310 deg  bank 45 deg
straight             60 s

# Home, eastwards
horizontal_turn      left 348 deg  bank 35 deg
straight             500 s
climb                to 2000 m  angle 3 deg
straight             800 s

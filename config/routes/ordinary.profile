# SPDX-License-Identifier: Apache-2.0
# A calm mission of 50 min over the Swedish east coast: straight legs and long turns, altitude
# between 2000 and 3500 m, no hard manoeuvring.
start                lat 57.4 deg  lon 16.2 deg  altitude 2000 m  heading 15 deg  speed 180 m/s

straight             180 s
climb                to 2800 m  angle 4 deg
horizontal_turn      right 75 deg  bank 30 deg
straight             60 s

# Turning, 450 to 900 s
horizontal_turn      left 120 deg  bank 35 deg
straight             25 s
horizontal_turn      right 150 deg  bank 30 deg
straight             20 s
horizontal_turn      right 90 deg  bank 45 deg
speed_change         to 200 m/s  in 30 s
horizontal_turn      left 180 deg  bank 40 deg
climb                to 3480 m  angle 5 deg
horizontal_turn      right 270 deg  bank 35 deg
heading_oscillation  amplitude 12 deg  period 40 s  cycles 3
horizontal_turn      left 60 deg  bank 20 deg

# A long way north-west with few turns
straight             300 s
speed_change         to 215 m/s  in 40 s
horizontal_turn      left 75 deg  bank 30 deg
straight             90 s
climb                to 2600 m  angle 4 deg
horizontal_turn      left 40 deg  bank 25 deg
straight             100 s
horizontal_turn      left 125 deg  bank 40 deg
straight             60 s
vertical_turn        to 3 deg  load 1.2 g
straight             50 s
vertical_turn        to 0 deg  load 0.8 g

# Straight home, with one slight turn
straight             150 s
horizontal_turn      right 12 deg  bank 20 deg
speed_change         to 185 m/s  in 60 s
straight             200 s

# Turning again, 2500 to 3000 s
horizontal_turn      left 90 deg  bank 45 deg
straight             15 s
horizontal_turn      right 180 deg  bank 35 deg
climb                to 2200 m  angle 4 deg
horizontal_turn      right 120 deg  bank 50 deg
heading_oscillation  amplitude 15 deg  period 45 s  cycles 2
horizontal_turn      left 210 deg  bank 35 deg
straight             30 s
horizontal_turn      right 90 deg  bank 30 deg
climb                to 2000 m  angle 3 deg
straight             300 s

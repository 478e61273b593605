# SPDX-License-Identifier: Apache-2.0
# A small unmanned aircraft: 25 +- 1 m/s, and a turn of 30 s at 25 degrees of bank every 120 s.
start            lat 57.5 deg  lon 16.0 deg  altitude 400 m  heading 0 deg  speed 25 m/s

speed_change     to 26 m/s  in 45 s
speed_change     to 25 m/s  in 45 s
horizontal_turn  right 285 deg  in 30 s  roll_rate 30 deg/s

speed_change     to 24 m/s  in 45 s
speed_change     to 25 m/s  in 45 s
horizontal_turn  left 285 deg  in 30 s  roll_rate 30 deg/s

speed_change     to 26 m/s  in 45 s
speed_change     to 25 m/s  in 45 s
horizontal_turn  right 285 deg  in 30 s  roll_rate 30 deg/s

speed_change     to 24 m/s  in 45 s
speed_change     to 25 m/s  in 45 s
horizontal_turn  left 285 deg  in 30 s  roll_rate 30 deg/s

speed_change     to 26 m/s  in 45 s
speed_change     to 25 m/s  in 45 s
horizontal_turn  right 285 deg  in 30 s  roll_rate 30 deg/s

speed_change     to 24 m/s  in 45 s
speed_change     to 25 m/s  in 45 s
horizontal_turn  left 285 deg  in 30 s  roll_rate 30 deg/s

speed_change     to 26 m/s  in 45 s
speed_change     to 25 m/s  in 45 s
horizontal_turn  right 285 deg  in 30 s  roll_rate 30 deg/s

speed_change     to 24 m/s  in 45 s
speed_change     to 25 m/s  in 45 s
horizontal_turn  left 285 deg  in 30 s  roll_rate 30 deg/s

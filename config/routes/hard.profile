# SPDX-License-Identifier: Apache-2.0
# Hard manoeuvring between two calm parts: rolls, loops, split-S, turns of 60 to 80 degrees of bank
# and 4 to 6 g; then calm again, to see what is left of it.
start                lat 57.5 deg  lon 16.3 deg  altitude 2500 m  heading 30 deg  speed 190 m/s

# Calm, with turns in which the biases show
straight             120 s
horizontal_turn      left 90 deg  bank 35 deg
straight             60 s
horizontal_turn      right 180 deg  bank 40 deg
heading_oscillation  amplitude 15 deg  period 40 s  cycles 2
horizontal_turn      left 120 deg  bank 45 deg
climb                to 3500 m  angle 6 deg
straight             40 s

# Rolls
aileron_roll         right 1  rate 120 deg/s
straight             10 s
aileron_roll         left 1  rate 120 deg/s
straight             10 s
aileron_roll         right 2  rate 120 deg/s  load 0.5 g
straight             20 s
aileron_roll         left 1  rate 60 deg/s  load 0.8 g
straight             20 s

# Steep turns, rolled into and reversed quickly
speed_change         to 220 m/s  in 20 s
horizontal_turn      right 180 deg  load 4 g  roll_rate 90 deg/s
horizontal_turn      left 270 deg  load 5 g  roll_rate 120 deg/s
straight             10 s
horizontal_turn      right 90 deg  bank 60 deg  roll_rate 90 deg/s
horizontal_turn      left 90 deg  bank 70 deg  roll_rate 90 deg/s
horizontal_turn      right 360 deg  load 6 g  roll_rate 120 deg/s
straight             30 s

# Loops
loop                 load 5 g
straight             20 s
loop                 load 6 g
loop                 load 5.5 g
straight             30 s

# Split-S and climb back, twice
climb                to 4500 m  angle 25 deg  load 1.5 g
speed_change         to 150 m/s  in 20 s
split_s              load 5.5 g
speed_change         to 220 m/s  in 15 s
climb                to 4500 m  angle 30 deg  load 1.5 g
speed_change         to 150 m/s  in 20 s
split_s              load 6 g  rate 150 deg/s
speed_change         to 220 m/s  in 15 s

# All of it in a row
vertical_turn        to 35 deg  load 4 g
vertical_turn        to 0 deg  load -0.5 g
aileron_roll         right 2  rate 150 deg/s
horizontal_turn      left 180 deg  load 6 g  roll_rate 150 deg/s
loop                 load 5 g
horizontal_turn      right 270 deg  load 4.5 g  roll_rate 120 deg/s
aileron_roll         left 1  rate 90 deg/s
vertical_turn        to -30 deg  load 0.2 g
vertical_turn        to 0 deg  load 5 g
horizontal_turn      left 360 deg  bank 78 deg  roll_rate 120 deg/s
straight             20 s
loop                 load 5 g
aileron_roll         right 3  rate 120 deg/s  load 0.8 g
horizontal_turn      right 540 deg  load 4 g  roll_rate 90 deg/s
straight             30 s
horizontal_turn      left 720 deg  bank 65 deg  roll_rate 60 deg/s

# Calm again
straight             60 s
speed_change         to 190 m/s  in 30 s
climb                to 3000 m  angle 4 deg
horizontal_turn      left 90 deg  bank 30 deg
straight             120 s
horizontal_turn      right 180 deg  bank 35 deg
straight             90 s
heading_oscillation  amplitude 12 deg  period 40 s  cycles 2
horizontal_turn      left 270 deg  bank 40 deg
straight             120 s
climb                to 2500 m  angle 4 deg
horizontal_turn      right 90 deg  bank 30 deg
straight             300 s

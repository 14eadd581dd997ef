"""The program of the car_mems board (STM32F405): acquisition, navigation, outputs, background."""

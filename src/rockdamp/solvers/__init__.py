"""Two ways to solve the equation of motion.

`newmark` is the fast stepper of many histories, `exact` the event-driven reference. They share no
stepping code, so that each can check the other. Other packages interpret the histories.
"""

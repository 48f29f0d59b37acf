"""Two ways to solve the equation of motion: the fast stepper over many histories, and the event-driven reference.

They share no stepping code, so that each can check the other; what a history means is read elsewhere.
"""

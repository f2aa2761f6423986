"""Identification of a cart double pendulum from free-swing trials."""

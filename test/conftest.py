"""What every test stands on: DDS that stays on this machine, on a domain of this run's own."""

import os

from hypothesis import settings

os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ.setdefault("ROS_DOMAIN_ID", str(os.getpid() % 100 + 1))

# The first example of a property may have to compile the model; how long an example takes says nothing about it.
settings.register_profile("cdp_ident", deadline=None)
settings.load_profile("cdp_ident")

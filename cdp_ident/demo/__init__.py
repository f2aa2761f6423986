"""The whole way from an emulated rig to served parameters, each node a process of its own as on a real rig."""

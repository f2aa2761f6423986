"""What the nodes share: their life, parameters and topics."""

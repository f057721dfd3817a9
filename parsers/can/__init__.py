"""CAN: frames in columns, DBC databases, and the decoding of payloads in bulk."""

"""ROS messages in columns: definitions to field programs, and compiled decoders for ROS 1 and CDR."""

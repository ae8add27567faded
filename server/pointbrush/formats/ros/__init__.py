"""Recordings of ROS: bags of both generations and MCAP files, their clouds, pictures and poses."""

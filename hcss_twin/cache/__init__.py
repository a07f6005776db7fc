"""What is kept between runs on this machine, because it would come out the same."""

"""What the documents say in numbers, and where each number comes from."""

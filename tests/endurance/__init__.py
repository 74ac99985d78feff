"""What lasts: interrupts, copies, long runs, memory."""

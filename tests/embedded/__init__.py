"""C code on Cortex-M processors that QEMU emulates: startup, linker script, measurement."""

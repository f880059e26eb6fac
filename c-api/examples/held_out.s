/* Recorded traces of the standard rig: three 16-bit counts a sample. */
    .section .rodata.held_out, "a"
    .balign 4
    .global held_out_start, held_out_end
held_out_start:
    .incbin "held_out.bin"
held_out_end:

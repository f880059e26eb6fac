@ The model of the standard rig with a signature, as a sector of flash has it.
    .section .rodata.signed, "a"
    .balign 4
    .global signed_start, signed_end
signed_start:
    .incbin "signed.bwm"
signed_end:

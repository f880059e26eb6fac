/* A recording of raw counts, as `bearing-watch replay --rows` writes it. */
    .section .rodata.rows, "a"
    .balign 4
    .global rows_start, rows_end
rows_start:
    .incbin "rows.bin"
rows_end:

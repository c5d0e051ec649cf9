/* The live page as web/ bundles it; PLUMBLINE_LIVE_PAGE is its path. */
        .section .rodata
        .global plumbline_live_page
        .global plumbline_live_page_end
plumbline_live_page:
        .incbin PLUMBLINE_LIVE_PAGE
plumbline_live_page_end:
        .byte 0
        .section .note.GNU-stack, "", %progbits

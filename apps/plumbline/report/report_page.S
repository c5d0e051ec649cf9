/* The page as web/ bundles it; PLUMBLINE_REPORT_PAGE is its path. */
        .section .rodata
        .global plumbline_report_page
        .global plumbline_report_page_end
plumbline_report_page:
        .incbin PLUMBLINE_REPORT_PAGE
plumbline_report_page_end:
        .byte 0
        .section .note.GNU-stack, "", %progbits

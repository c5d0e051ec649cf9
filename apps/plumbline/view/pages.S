/* What web/ bundles; the names in capitals are paths. */
        .section .rodata
        .global plumbline_report_page, plumbline_report_page_end, plumbline_live_page, plumbline_live_page_end
        .global plumbline_page_packages, plumbline_page_packages_end
plumbline_report_page:
        .incbin PLUMBLINE_REPORT_PAGE
plumbline_report_page_end:
        .byte 0
plumbline_live_page:
        .incbin PLUMBLINE_LIVE_PAGE
plumbline_live_page_end:
        .byte 0
plumbline_page_packages:
        .incbin PLUMBLINE_PAGE_PACKAGES
plumbline_page_packages_end:
        .byte 0
        .section .note.GNU-stack, "", %progbits

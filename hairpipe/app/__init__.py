"""What people and programs start: Python interface, command line, page, tuning, wedges, farms."""

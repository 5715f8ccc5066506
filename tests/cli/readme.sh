skip "not written"

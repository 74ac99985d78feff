"""Operations on sets: t-norms, extension, join and meet, union, relations and measures."""

// In the place of what the view AR draws with, where ninedot-web was built without it.
export const isAbsent = true;
